"""The field's own tests: rows of references, what Talus gives, and whether both agree."""
