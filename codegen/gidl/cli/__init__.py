"""The command line of the compiler. Each verb has a module; the other modules are shared by the
verbs."""
