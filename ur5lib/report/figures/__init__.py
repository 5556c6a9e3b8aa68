"""The drawings of reports and papers, and the numbers that each shows."""
