"""By which shock: pieces of a pulse, trains of blows, records, and the directions of a study."""
