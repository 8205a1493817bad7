// The zoom of VR Stage Lighting's mover, 0 to 1 from 1.75 to 19.8 degrees of half angle; 4 times it is its cone width.
float vrsl_zoom(BeamRow row) { return clamp((degrees(atan(row.y_axis.w)) - 1.75) / 18.05, 0.0, 1.0); }
