"""Labels -> questions and answers, and labelled recordings -> clips; knows no network."""
