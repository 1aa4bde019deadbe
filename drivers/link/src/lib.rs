//! Transports for the two devices: serial port, TCP, pseudo-terminal, and transcripts of dialogues.
