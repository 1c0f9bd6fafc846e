#define MANY 4
