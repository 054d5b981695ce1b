"""Code generation for laws and drives: they are recorded once, and printed in any language."""
