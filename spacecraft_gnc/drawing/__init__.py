"""Drawing library: style, the unit sphere, charts of a page, figures for print."""
