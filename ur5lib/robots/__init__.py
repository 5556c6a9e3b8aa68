"""Arms as data: descriptions, statics, inverse kinematics, collisions, exports."""
