"""Files that users write and keep: scenarios and designs."""
