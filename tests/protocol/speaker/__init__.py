"""A speaker of docs/protocol.md: no line of ours is used, and none was read to write it.

From the bottom up: `lcm` (datagrams), `noise` (keys and ciphers), `frames` (what is sealed, and
large packets in pieces), `packets` (values and packets), `streams`. On them stand a client
(`connection`, `client`, `broker`) and a server (`listener`, `arrivals`, `tasks`, `served`,
`reserved`, `server`). One thread: `lcm.Loop` runs whatever takes part until something has happened.
"""
