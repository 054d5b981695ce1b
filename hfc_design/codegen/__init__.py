"""Laws and drives as code: recorded once, printed in any language."""
