// What the materials of the scene have: a coat, sheen or iridescence; transmission.
override has_layers: bool = true;
override has_transmission: bool = true;

// Whether a cache knows some of the light that comes to surfaces, and paths leave behind how they scatter it.
override leaves_diffuse: bool = false;
