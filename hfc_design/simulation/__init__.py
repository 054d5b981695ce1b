"""The closed loop of one machine, of populations, of one design on one scenario."""
