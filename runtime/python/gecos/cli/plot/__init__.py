"""Records a motion of an arm and draws it: `gecos plot`."""
