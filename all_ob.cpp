#include "/tmp/ob/mock_ob/server.cpp"
