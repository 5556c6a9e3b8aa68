"""Result tables, figures, and the document in HTML and PDF."""
