"""Many runs at once: what is asked, who trains them, the folder that keeps them, tables of them."""
