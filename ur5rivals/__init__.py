"""Published estimators of the contact force, and own ones, compared with those of this project."""
