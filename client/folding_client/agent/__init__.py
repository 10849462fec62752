"""The agent: query the model, execute its tool calls, append the results (paper, section "Agentic
Framework").
"""
