"""Where and how an object can be used: places to sit, to put and to pour, proposed without any engine."""
