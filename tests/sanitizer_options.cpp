/// What sanitized test programs ask of the address sanitizer.
extern "C" const char* __asan_default_options() { return "allocator_may_return_null=1"; }
