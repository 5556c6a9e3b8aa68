"""What contradicts a recording, or the study that declares it: findings, as codes and numbers."""
