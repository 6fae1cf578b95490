/// What sanitized test programs ask of the address sanitizer, and of the leak sanitizer in it.
extern "C" const char* __asan_default_options() { return "allocator_may_return_null=1"; }
/// OpenImageIO keeps the message of an image that libpng left by a long jump.
extern "C" const char* __lsan_default_suppressions() {
    return "leak:OpenImageIO_v2_4::ImageInput::geterror\n";
}
