def write_report(scenario, result, rivals, folder):
    pass
