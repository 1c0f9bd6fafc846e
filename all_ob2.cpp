#include "/tmp/ob/mock_ob2/server.cpp"
