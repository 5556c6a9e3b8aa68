"""A laboratory: designed motions, the recorder of its devices, and doubles of these."""
