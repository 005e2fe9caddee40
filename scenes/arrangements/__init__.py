"""Several objects together: where each stands, which of them carries a sphere, and what one takes away from another."""
