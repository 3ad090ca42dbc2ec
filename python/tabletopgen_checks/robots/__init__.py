"""Robots at work: tasks, their execution, and the planner beside another one."""
