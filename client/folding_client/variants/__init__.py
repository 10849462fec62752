"""The paper's ablation variants: VLM-CP, VLM-S, VLM-S-C, and examples in context."""
