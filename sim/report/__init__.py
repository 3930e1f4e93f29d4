"""What people are shown: report, tables, status, a run in words, and what is published."""
