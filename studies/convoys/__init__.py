"""Studies on recorded convoys: laws fitted to their cars, and laws behind their leaders."""
