"""Cable models: a route says where the free part of a cable starts, a law what it does under tension."""
