// Decode every message of MCAP files with Foxglove's own libraries, which share no code with ours.
//
//     node decode.mjs FILE.mcap...
//
// Prints {"topics": {TOPIC: MESSAGES}, "metadata": {NAME: RECORDS}} as JSON, of all files together.
// A file, chunk, definition or message that cannot be read ends it with an error.

import { readFile } from "node:fs/promises";
import { argv } from "node:process";

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";

const DECOMPRESSORS = { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) };

const topics = {};
const metadata = {};

function channelReader(channel, schemas) {
  const schema = schemas.get(channel.schemaId);
  if (channel.messageEncoding !== "cdr" || schema?.encoding !== "ros2msg") {
    throw new Error(`${channel.topic}: ${channel.messageEncoding}, ${schema?.encoding}`);
  }
  const definition = parse(new TextDecoder().decode(schema.data), { ros2: true });
  return { topic: channel.topic, reader: new MessageReader(definition) };
}

for (const path of argv.slice(2)) {
  const stream = new McapStreamReader({ decompressHandlers: DECOMPRESSORS, validateCrcs: true });
  stream.append(await readFile(path));
  const schemas = new Map();
  const channels = new Map();
  for (let record; (record = stream.nextRecord()); ) {
    if (record.type === "Schema") {
      schemas.set(record.id, record);
    } else if (record.type === "Channel" && !channels.has(record.id)) {
      channels.set(record.id, channelReader(record, schemas));
    } else if (record.type === "Metadata") {
      metadata[record.name] = (metadata[record.name] ?? 0) + 1;
    } else if (record.type === "Message") {
      const { topic, reader } = channels.get(record.channelId);
      reader.readMessage(record.data);
      topics[topic] = (topics[topic] ?? 0) + 1;
    }
  }
  if (!stream.done()) {
    throw new Error(`${path}: not read to its end`);
  }
}
console.log(JSON.stringify({ topics, metadata }));
