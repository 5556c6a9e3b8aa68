"""Force sensor, contact wrench and contact detection."""
