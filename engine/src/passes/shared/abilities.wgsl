// What the materials of the scene have: a coat, sheen or iridescence; transmission.
override has_layers: bool = true;
override has_transmission: bool = true;
