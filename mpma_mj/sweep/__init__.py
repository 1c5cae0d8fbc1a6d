"""Many runs at once: what is spec, who trains them, the folder that keeps them, tables of them."""
