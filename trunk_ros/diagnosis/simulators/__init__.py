"""Another simulator in the place of the nominal model."""
