"""docs/security.md says that the wheels have no DDS security: a node then refuses to start."""

from __future__ import annotations

import os
import subprocess
import sys

FILES = (
    "identity_ca.cert.pem",
    "cert.pem",
    "key.pem",
    "permissions_ca.cert.pem",
    "governance.p7s",
    "permissions.p7s",
)
NODE = "import rclpy; rclpy.init(); rclpy.create_node('nobody')"


def test_with_security_asked_for_no_node_starts_unprotected(tmp_path):
    enclave = tmp_path / "enclaves"
    enclave.mkdir()
    for name in FILES:
        (enclave / name).touch()
    asked = {
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_KEYSTORE": str(tmp_path),
    }
    ended = subprocess.run(
        [sys.executable, "-c", NODE],
        env=os.environ | asked,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 1
    assert "doesn't have the security libraries" in ended.stderr
