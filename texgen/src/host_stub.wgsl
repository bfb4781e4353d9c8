// What the host supplies to the generated kernel, doing nothing.
