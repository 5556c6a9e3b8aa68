"""Force sensor and contact wrench."""
