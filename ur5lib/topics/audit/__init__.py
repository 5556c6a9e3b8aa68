"""What is wrong with the force sensor in an arm's wrist."""
