// ThreadSanitizer's default suppressions. Compiled into every program of the tsan preset, so they
// apply however a program is started.
//
// In Debian's libraries the sanitizer sees only calls of memcpy, free and similar functions, not
// the atomics that order them. called_from_lib ignores these calls. It does not ignore what the
// functions do for our own code, or our code when such a library calls it.
//
// The list contains the libraries of gRPC, protobuf and Cyclone DDS, and the loader, which frees
// data of ended threads. The standard library is missing because our own code calls it.
//
// Suppressions by function or file would also hide the code that they call. Two suppress code that
// calls none of ours. The threads of the metrics page's server share the result of gmtime.
// FinishOp, compiled from gRPC's headers, copies the message of a status that a thread of gRPC
// made; the standard library allocates it, which is not in the list.

// Called by the sanitizer before static objects are constructed.
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
         "race:libcivetweb.so\n"
         "race:grpc::internal::CallOpClientRecvStatus::FinishOp\n";
}
