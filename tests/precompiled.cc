// A program to compile the tests' common headers with (tests/CMakeLists.txt).
int main() {}
