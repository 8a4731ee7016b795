/* Counts the calls of MPI that send or receive, by PETSc or by anybody, through MPI's profiling interface. */
#include <mpi.h>

long messages_of_mpi = 0;

#define COUNTED(name, parameters, arguments) \
    int MPI_##name parameters {              \
        ++messages_of_mpi;                   \
        return PMPI_##name arguments;        \
    }

COUNTED(Send, (const void* b, int n, MPI_Datatype t, int r, int tag, MPI_Comm c), (b, n, t, r, tag, c))
COUNTED(Isend, (const void* b, int n, MPI_Datatype t, int r, int tag, MPI_Comm c, MPI_Request* q),
        (b, n, t, r, tag, c, q))
COUNTED(Recv, (void* b, int n, MPI_Datatype t, int r, int tag, MPI_Comm c, MPI_Status* s), (b, n, t, r, tag, c, s))
COUNTED(Irecv, (void* b, int n, MPI_Datatype t, int r, int tag, MPI_Comm c, MPI_Request* q), (b, n, t, r, tag, c, q))
COUNTED(Start, (MPI_Request * q), (q))
COUNTED(Startall, (int n, MPI_Request* q), (n, q))
COUNTED(Barrier, (MPI_Comm c), (c))
COUNTED(Bcast, (void* b, int n, MPI_Datatype t, int r, MPI_Comm c), (b, n, t, r, c))
COUNTED(Reduce, (const void* b, void* a, int n, MPI_Datatype t, MPI_Op o, int r, MPI_Comm c), (b, a, n, t, o, r, c))
COUNTED(Allreduce, (const void* b, void* a, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), (b, a, n, t, o, c))
COUNTED(Iallreduce, (const void* b, void* a, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c, MPI_Request* q),
        (b, a, n, t, o, c, q))
COUNTED(Scan, (const void* b, void* a, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), (b, a, n, t, o, c))
COUNTED(Exscan, (const void* b, void* a, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), (b, a, n, t, o, c))
COUNTED(Gather, (const void* b, int n, MPI_Datatype t, void* a, int m, MPI_Datatype u, int r, MPI_Comm c),
        (b, n, t, a, m, u, r, c))
COUNTED(Allgather, (const void* b, int n, MPI_Datatype t, void* a, int m, MPI_Datatype u, MPI_Comm c),
        (b, n, t, a, m, u, c))
COUNTED(Alltoall, (const void* b, int n, MPI_Datatype t, void* a, int m, MPI_Datatype u, MPI_Comm c),
        (b, n, t, a, m, u, c))
COUNTED(Comm_dup, (MPI_Comm c, MPI_Comm* d), (c, d))
