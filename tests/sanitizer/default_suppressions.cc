// What ThreadSanitizer shall not look at. Compiled into every program of the tsan preset, so it
// holds however a program is started.
//
// The sanitizer sees nothing of Debian's libraries but their calls of memcpy, free and the like,
// and nothing of the atomics that order these. Their calls are ignored; what these functions do for
// our own code is not, and neither is our code when such a library calls it. These are the
// libraries that gRPC, protobuf and Cyclone DDS are made of, and the loader, which gives up what
// belonged to threads that have ended. The standard library is not among them, because our own code
// calls it, and there is no suppression by function or file, which would hide what is below it,
// too; but for two that call nothing of ours: the plugins of DDS Security, which are unloaded at
// times (the sanitizer ends a program that unloads one of the libraries above), and the server of
// the metrics page, whose threads share the time that gmtime returns.

// The sanitizer calls it before the program's static objects are made.
extern "C" const char* __tsan_default_suppressions() {
  return "called_from_lib:ld-linux-x86-64.so\n"
         "called_from_lib:libabsl_cord.so\n"
         "called_from_lib:libabsl_cord_internal.so\n"
         "called_from_lib:libabsl_cordz_handle.so\n"
         "called_from_lib:libabsl_cordz_info.so\n"
         "called_from_lib:libabsl_graphcycles_internal.so\n"
         "called_from_lib:libabsl_random_internal_pool_urbg.so\n"
         "called_from_lib:libabsl_status.so\n"
         "called_from_lib:libabsl_statusor.so\n"
         "called_from_lib:libabsl_str_format_internal.so\n"
         "called_from_lib:libabsl_strerror.so\n"
         "called_from_lib:libabsl_strings.so\n"
         "called_from_lib:libabsl_strings_internal.so\n"
         "called_from_lib:libabsl_synchronization.so\n"
         "called_from_lib:libabsl_time.so\n"
         "called_from_lib:libabsl_time_zone.so\n"
         "called_from_lib:libaddress_sorting.so\n"
         "called_from_lib:libcares.so\n"
         "called_from_lib:libcrypto.so\n"
         "called_from_lib:libddsc.so\n"
         "called_from_lib:libgpr.so\n"
         "called_from_lib:libgrpc.so\n"
         "called_from_lib:libgrpc++.so\n"
         "called_from_lib:libprotobuf.so\n"
         "called_from_lib:libssl.so\n"
         "called_from_lib:libupb.so\n"
         "race:libdds_security_\n"
         "race:libcivetweb.so\n";
}
