"""The commands of `ur5`: one module for each, and modules that several of them share."""
