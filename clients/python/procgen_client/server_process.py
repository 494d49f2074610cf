"""placeholder"""
class ServerProcess: pass
