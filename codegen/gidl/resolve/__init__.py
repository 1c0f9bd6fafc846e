"""From syntax trees to the model: names are looked up, constants computed, annotations read."""
