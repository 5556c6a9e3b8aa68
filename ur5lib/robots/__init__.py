"""Arms as data: descriptions, statics, inverse kinematics, exports."""
