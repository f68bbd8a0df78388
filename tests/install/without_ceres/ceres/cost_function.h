#error "public headers are free of the solver"
