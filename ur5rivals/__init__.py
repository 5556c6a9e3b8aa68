"""Published estimators of the contact force, and own ones, beside those of this project."""
