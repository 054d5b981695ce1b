"""Code generation for laws and drives: recorded once, printed in any language."""
