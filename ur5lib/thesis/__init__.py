"""What only the study of the thesis needs: its methods as printed, its numbers and its errata."""
