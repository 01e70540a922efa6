int a;
/* never
   ends
