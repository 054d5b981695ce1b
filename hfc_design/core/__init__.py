"""Foundation of every other package: checked records, errors, files, plug-ins, devices."""
