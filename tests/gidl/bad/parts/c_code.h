#pragma once
#include <stddef.h>
int main(int argc, char **argv) { return 0; }
struct s { void *p; };
