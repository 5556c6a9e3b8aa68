"""Steps of the workflow: how a rule runs its script in a process that is warm already."""
