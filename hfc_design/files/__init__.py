"""What users write and keep: scenarios and designs."""
