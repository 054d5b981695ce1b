"""What every other part stands on: checked records, errors, files, plug-ins, devices."""
