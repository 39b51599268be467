"""Recorded convoys: tables of several cars, and the scenarios made from them."""
