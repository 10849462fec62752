"""The models beside the agent, each in its role: critic, overview critic, selector."""
